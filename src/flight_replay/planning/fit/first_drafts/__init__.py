"""The drafts that a search begins with: which places a route has before it is flown in the model."""
