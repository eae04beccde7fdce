"""Drawing shared by several pages: pictures of robots, films, axes."""
