# C++ unit tests and rostests; the Python unit tests need no build (make test-fast).
find_package(rostest REQUIRED)
