#!/usr/bin/env bash
# The tests: those that need no ROS on every core, then those that start it, two at a time where there are two cores.
#   tools/test.sh [fast] [arguments of pytest]     fast leaves the second part out
# Needs tools/env.sh sourced and, for the second part, the package built. In the first part all tests of a file run in
# one process, in their order, so that the number of cores decides nothing but the time. In the second each test has a
# ROS master of its own and most of them run in simulated time; those that share a run are marked with xdist_group.
# A system of nodes keeps two cores busy by itself only while it drives, so more than two at a time gain nothing.
cd "$(dirname "$0")/.." || exit 1
none_found=5

part=all
if [ "${1:-}" = fast ]; then
  part=fast
  shift
fi
python3 -m pytest -n "$(nproc)" --dist loadfile test/python test/contract "$@"
status=$?
[ "$part" = all ] || exit "$status"
python3 -m pytest -n "$(($(nproc) < 2 ? 1 : 2))" --dist loadgroup test/cpp test/ros test/system "$@"
second=$?
# A selection (-k) that leaves nothing of one part is no fault as long as the other part has something.
if [ "$status" -eq 0 ] && [ "$second" -eq "$none_found" ]; then
  second=0
elif [ "$status" -eq "$none_found" ]; then
  status=$second
fi
[ "$status" -ne 0 ] && exit "$status"
exit "$second"
