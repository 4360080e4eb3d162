"""Steps of all places, speeds and waits of a draft together."""
