run oscillating.json
