"""What if: the cell as it is, forked into many kinematic missions under alternatives."""
