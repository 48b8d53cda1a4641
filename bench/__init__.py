"""Side by side with other tools: see bench/README.md."""
