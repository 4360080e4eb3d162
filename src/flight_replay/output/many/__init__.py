"""The table of many flights: its columns and files, its summary and report, and two of them compared."""
