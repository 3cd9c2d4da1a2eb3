# Sourced by the Makefile and by people: the environment every command of the project runs in.
#   source tools/env.sh
# Debian's python3 and the project's virtual environment come first, whatever else is on PATH; ROS stays on loopback.
yarm_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export PATH="$yarm_root/.venv/bin:/usr/sbin:/usr/bin:/sbin:/bin:$PATH"
unset PYTHONHOME
# Every node compiles all its sources anew where this is set, as containers often have it: half of what a start takes.
unset PYTHONDONTWRITEBYTECODE
export ROS_HOSTNAME=localhost
export ROS_MASTER_URI="${ROS_MASTER_URI:-http://localhost:11311}"
yarm_devel="${YARM_BUILD:+$YARM_BUILD/devel}"
yarm_devel="${yarm_devel:-$yarm_root/devel}"
if [ -f "$yarm_devel/setup.bash" ]; then
  # shellcheck disable=SC1091
  source "$yarm_devel/setup.bash"
fi
export YARM_ROOT="$yarm_root"
# What was compiled in one checkout or catkin workspace need not be in another one: paths within it count as relative.
if command -v ccache >/dev/null; then
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache
  export CCACHE_BASEDIR="${yarm_root%/src/*}" CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=locale
fi
