"""The simulated TIAGo as ROS shows it: joints, controllers and topics, with no word of the contract."""
