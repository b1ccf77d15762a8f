"""Local density of sarcomeres."""
