"""What we use of scipy, which has no types."""
