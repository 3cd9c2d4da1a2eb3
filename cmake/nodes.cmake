# The perception nodes: nodelets, and the same classes as standalone nodes.
