"""Charts of a replay: a page of plots, interactive charts, and the HTML report."""
