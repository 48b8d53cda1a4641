"""A thousand aircraft far away at one ground station and router, beside Zenoh with nothing of ours."""
