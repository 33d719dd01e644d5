run limit_before_until.json
