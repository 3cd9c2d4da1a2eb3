"""The mobile robots' bases: kinematics, controller, model."""
