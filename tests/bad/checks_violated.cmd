run checks_violated.json
