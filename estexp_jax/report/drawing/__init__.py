"""What several pages draw with: pictures of robots, films, axes."""
