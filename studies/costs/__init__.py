"""What laws cost inside the engines."""
