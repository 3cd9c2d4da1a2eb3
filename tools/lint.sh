#!/usr/bin/env bash
# All linters; every one runs, then the verdict. Needs tools/env.sh sourced and the package built.
cd "$(dirname "$0")/.." || exit 1
failed=()
check() {
  local name=$1
  shift
  printf '== %s\n' "$name"
  "$@" || failed+=("$name")
}
mapfile -t cpp < <(git ls-files '*.cpp' '*.hpp')
mapfile -t launches < <(git ls-files 'launch/*/*.launch')

# The launch files check their arguments themselves: a window needs a screen, a replay a file, a real cell a scene.
launch_check() {
  local file status=0
  for file in "${launches[@]}"; do
    local arguments=()
    [ "$file" != launch/cell/replay.launch ] || arguments=("bag:=$PWD/package.xml")
    [ "$file" != launch/cell/real_cell.launch ] || arguments=("cell:=1m1ma")
    DISPLAY=:0 /usr/bin/python3 /usr/share/roslaunch/scripts/roslaunch-check "$file" "${arguments[@]}" || status=1
  done
  return $status
}

check 'ruff format' ruff format --check src test bench tools scripts setup.py
check 'ruff' ruff check src test bench tools scripts setup.py
check 'mypy (strict)' mypy src/yarm
[ ${#cpp[@]} -eq 0 ] || check 'clang-format' clang-format --dry-run --Werror "${cpp[@]}"
check 'catkin_lint' catkin_lint -W1 --ignore unknown_package --ignore uninstalled_script .
check 'launch files' launch_check
check 'boundaries' python3 -m pytest -q test/python/package
if [ ${#failed[@]} -gt 0 ]; then
  printf 'lint: failed: %s\n' "${failed[*]}" >&2
  exit 1
fi
echo 'lint: all clean'
