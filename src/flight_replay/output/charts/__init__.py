"""Pictures: one page for matplotlib, interactive charts, the report."""
