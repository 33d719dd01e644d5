run unknown_control.json --x-control error
