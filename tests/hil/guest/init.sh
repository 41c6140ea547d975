#!/bin/busybox sh
# shellcheck shell=sh
# First program of the guest: mounts, loads the suite's drivers, runs the suite, says the verdict, switches off.
# The kernel hands `hil=SUITE`, `hil_filter=PATTERN` … of its command line on as environment variables.
: "${hil:?}" "${hil_filter:?}" "${hil_seconds:?}" "${hil_udev:?}" "${hil_long:?}"
/bin/busybox mkdir -p /bin /sbin /usr/bin /usr/sbin
/bin/busybox --install -s /bin
export PATH=/hil:/bin:/sbin LD_LIBRARY_PATH=/lib/x86_64-linux-gnu:/usr/lib/x86_64-linux-gnu
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs devtmpfs /dev
mount -t tmpfs tmpfs /tmp
mount -t tmpfs tmpfs /run
mkdir -p /dev/pts && mount -t devpts devpts /dev/pts
/hil/ip link set lo up

if [ -x /bin/udevadm ] && [ "$hil_udev" = 1 ]; then
  /lib/systemd/systemd-udevd --daemon || echo "HIL: udevd did not start"
fi
while read -r module; do
  insmod "$module" || echo "HIL: cannot load $module"
done <"/hil/$hil.modules"
[ -d /sys/kernel/config ] && mount -t configfs configfs /sys/kernel/config 2>/dev/null
[ "$hil_udev" = 1 ] && udevadm settle --timeout=20

echo "HIL: start $hil at $(cut -d' ' -f1 /proc/uptime) s, kernel $(uname -r)"
[ "$hil_long" = 1 ] && export ANNULUS_LONG=1
timeout -s KILL "$hil_seconds" /hil/hil_guest --gtest_filter="$hil_filter" --gtest_color=no </dev/null
status=$?
dmesg | grep -E 'BUG:|Oops|WARNING:' | sed 's/^/HIL: complaint: /'
echo "HIL: verdict $hil exit $status after $(cut -d' ' -f1 /proc/uptime) s"
sync
poweroff -f
