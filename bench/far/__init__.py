"""A thousand remote aircraft at one ground station and router, compared with bare Zenoh."""
