"""ULog, which PX4 writes."""
