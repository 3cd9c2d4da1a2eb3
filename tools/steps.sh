# Sourced by the other tools: long steps that show progress, and that name themselves and their log when they fail.
YARM_LOGS="${YARM_LOGS:-$PWD/log}"

say() { printf '\033[1m== %s\033[0m\n' "$*"; }

# step NAME COMMAND...: runs the command with its output in log/NAME.log and a line of progress every ten seconds.
step() {
  local name=$1 log started pid status
  shift
  mkdir -p "$YARM_LOGS"
  log="$YARM_LOGS/$name.log"
  started=$SECONDS
  say "$name: $*" | cut -c1-140
  "$@" >"$log" 2>&1 </dev/null &
  pid=$!
  while kill -0 "$pid" 2>/dev/null; do
    for _ in 1 2 3 4 5 6 7 8 9 10; do
      sleep 1
      kill -0 "$pid" 2>/dev/null || break 2
    done
    printf '   %s: %d s ... %s\n' "$name" "$((SECONDS - started))" "$(tail -n 1 "$log" | tr -d '\r' | cut -c1-100)"
  done
  wait "$pid"
  status=$?
  if [ "$status" -ne 0 ]; then
    printf 'FAILED: step "%s" ended with exit code %d after %d s; its last lines, and the whole log in %s:\n' \
      "$name" "$status" "$((SECONDS - started))" "$log" >&2
    tail -n 25 "$log" >&2
    exit "$status"
  fi
  printf '   %s: done in %d s\n' "$name" "$((SECONDS - started))"
}
