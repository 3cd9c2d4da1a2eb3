"""The five-joint arm: forward, inverse in closed form, nearest poses, iterative methods, singularities."""
