"""What we use of PettingZoo's tools."""
