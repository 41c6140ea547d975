"""What stands at the other end of the guest's buses: our device models as processes of the host."""


from debian_kernel import HilError
from machine import end, spawn


class NoPeer:
    """A suite whose buses are inside the guest."""

    def __init__(self, folder, build):
        self.folder = folder
        self.build = build

    def start(self):
        """Before QEMU starts."""

    def devices(self):
        """QEMU's flags."""
        return []

    def answer(self, request):
        """Carries out a request of the guest; the text of its reply."""
        raise HilError(f"unknown request '{request}'")

    def close(self):
        """Whatever happened before."""


class UsbBoards(NoPeer):
    """placeholder"""

    def devices(self):
        return ["-device", "qemu-xhci,id=x"]


class AxisDrives(NoPeer):
    """placeholder"""

    def devices(self):
        return ["-serial", "null"]
