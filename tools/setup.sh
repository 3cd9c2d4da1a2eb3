#!/usr/bin/env bash
# Installs what the project needs on Debian 12: Debian packages, and a virtual environment with pinned PyPI packages.
# Safe to run again: what is already there is left alone, and a second run takes about a second.
set -u
cd "$(dirname "$0")/.." || exit 1
# shellcheck source=tools/steps.sh
source tools/steps.sh

packages=$(grep -v '^#' tools/debian-packages.txt)
stamp=.venv/.yarm-python-packages
wanted=$(cat tools/python-packages.txt tools/python-constraints.txt)

missing_packages() {
  local installed
  installed=$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' 2>/dev/null | sed -n 's/^ii *//p')
  comm -23 <(printf '%s\n' $packages | sort -u) <(printf '%s\n' "$installed" | sort -u)
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then
    "$@"
  elif command -v sudo >/dev/null 2>&1; then
    sudo -n true 2>/dev/null || say "sudo may ask for your password to install Debian packages"
    sudo DEBIAN_FRONTEND=noninteractive "$@"
  else
    echo "setup: $needed; as root run:" >&2
    echo "  $remedy" >&2
    return 1
  fi
}

missing=$(missing_packages | tr '\n' ' ')
if [ -n "${missing// /}" ]; then
  if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup: this needs Debian 12 (no apt-get here); packages wanted: tools/debian-packages.txt" >&2
    exit 1
  fi
  export DEBIAN_FRONTEND=noninteractive
  needed="$(echo $missing | wc -w) Debian packages are missing and installing them needs root or sudo"
  remedy="apt-get install --no-install-recommends $missing"
  step apt-update as_root apt-get update
  # shellcheck disable=SC2086
  step apt-install as_root apt-get install -y --no-install-recommends $missing
fi

if [ ! -x .venv/bin/python3 ] || [ "$(cat "$stamp" 2>/dev/null)" != "$wanted" ]; then
  step venv /usr/bin/python3 -m venv --clear --system-site-packages .venv
  step pip .venv/bin/python3 -m pip install --disable-pip-version-check \
    -c tools/python-constraints.txt -r tools/python-packages.txt
  printf '%s' "$wanted" >"$stamp"
fi

# ROS is bound to loopback by name; the barest of systems cannot look that name up.
if ! getent hosts localhost >/dev/null; then
  needed="the name localhost does not resolve, and mending that needs root or sudo"
  remedy="echo '127.0.0.1 localhost' >>/etc/hosts"
  step localhost as_root sh -c "$remedy"
fi
