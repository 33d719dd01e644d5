run two_tops.json
