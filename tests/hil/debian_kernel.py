"""Debian's current kernel for the tests on a real kernel: image, modules, drivers built from its source, udev.

Everything is downloaded with apt-get, never installed, and kept in a cache folder of parts. A part is a folder with a file
`stamp` that says what it was made of; it is made in a temporary folder and renamed, so that an interrupted run leaves no half part.
"""

import hashlib
import json
import lzma
import os
import re
import shutil
import subprocess

META_PACKAGE = "linux-image-amd64"  # depends on the current kernel
STATE = "versions.json"

# Drivers that Debian does not build. irq_sim is no module upstream: it gets a licence and reaches its descriptor by an
# exported way. Reason for `-DCONFIG_…`: the headers declare its functions only with the option on.
KBUILD = """\
ccflags-y := -DCONFIG_IRQ_SIM=1 -DCONFIG_GPIO_SIM=1
obj-m := irq_sim.o gpio-sim.o ctucanfd.o ctucanfd_pci.o
ctucanfd-y := ctucanfd_base.o
"""
IRQ_SIM_EDITS = [("irq_to_desc(irqnum)", "irq_data_to_desc(irq_get_irq_data(irqnum))")]
IRQ_SIM_TAIL = '\n#include <linux/module.h>\nMODULE_LICENSE("GPL");\n'
BUILT_MODULES = ("irq_sim", "gpio-sim", "ctucanfd", "ctucanfd_pci")
SOURCE_FILES = ("drivers/gpio/gpio-sim.c", "drivers/gpio/gpiolib.h", "kernel/irq/irq_sim.c", "drivers/net/can/ctucanfd/*")


class HilError(Exception):
    """The world failed; the text says what was attempted, what was seen and what to do."""


def run(command, what, advice, **options):
    """The output of a command; HilError if it fails."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True,
                              errors="replace", check=False, **options)
    except OSError as error:
        raise HilError(f"{what}: {error}: {advice}") from error
    except subprocess.TimeoutExpired as error:
        raise HilError(f"{what}: no end after {error.timeout:.0f} s: {advice}") from error
    if done.returncode != 0:
        lines = [line for line in done.stdout.splitlines() if line.strip()]
        seen = " | ".join(lines[-3:]) or f"exit {done.returncode}"
        raise HilError(f"{what}: {seen}: {advice}")
    return done.stdout


class KernelCache:
    """The parts, made when first asked for."""

    def __init__(self, folder, say):
        self.folder = folder
        self.say = say
        os.makedirs(folder, exist_ok=True)
        self.versions = self._load_versions()

    def tree(self, built):
        """Folder with lib/modules/<release>, depmod done; `built`: with the drivers that Debian does not build."""
        image = self._image()
        if not built:
            return os.path.join(image, "root")
        return self._part("tree", [self._stamp(image), self._stamp(self._modules())], self._make_tree)

    def vmlinux(self):
        return os.path.join(self._image(), "vmlinux")

    def udev(self):
        """Folder of the unpacked package udev."""
        return self._part("udev", [self._version("udev")], lambda f: self._unpack(["udev"], f))

    @property
    def release(self):
        """As `uname -r` says in the guest."""
        return self.versions["kernel"].removeprefix("linux-image-")

    # --- versions and downloads -----------------------------------------------------------------------------------------

    def _load_versions(self):
        path = os.path.join(self.folder, STATE)
        if os.path.exists(path):
            with open(path, encoding="utf-8") as f:
                return json.load(f)
        versions = self._current_kernel()
        self._save_versions(versions)
        return versions

    def _current_kernel(self):
        kernel = self._ask_apt(["depends", META_PACKAGE], r"Depends: (linux-image-[0-9]\S*-amd64)", META_PACKAGE)
        return {"kernel": kernel, kernel: self._candidate(kernel)}

    def renew(self):
        """After a failed download: whether Debian has a newer kernel than the one that was fixed at the first use. That is used from
        now on, since the archive does not keep the older one."""
        current = self._current_kernel()
        if all(self.versions.get(name) == version for name, version in current.items()):
            return False
        self.say(f"Debian's kernel is now {current['kernel']}: start anew with it")
        self.versions = current
        self._save_versions(current)
        return True

    def _candidate(self, package):
        return self._ask_apt(["policy", package], r"Candidate: (\d\S*)", package)

    def _save_versions(self, versions):
        path = os.path.join(self.folder, STATE)
        with open(path + ".new", "w", encoding="utf-8") as f:
            json.dump(versions, f, indent=1, sort_keys=True)
        os.rename(path + ".new", path)

    def _ask_apt(self, arguments, pattern, package):
        """The first group of the pattern in apt-cache's answer; the package lists are fetched once if they are empty."""
        for attempt in ("as they are", "after apt-get update"):
            answer = run(["apt-cache", *arguments], f"ask apt for {package}", "this needs Debian's apt")
            match = re.search(pattern, answer)
            if match:
                return match.group(1)
            if attempt == "as they are":
                self._update_lists()
        raise HilError(f"ask apt for {package}: it knows none: add Debian's main archive to /etc/apt/sources.list")

    def _update_lists(self):
        self.say("update the package lists")
        root = [] if os.geteuid() == 0 else ["sudo", "-n"]
        run([*root, "apt-get", "-q", "-y", "-o", "DPkg::Lock::Timeout=600", "update"], "apt-get update",
            "run it as root, with a network", timeout=600)

    def _version(self, package):
        """`package=version`, fixed at the first use; the source in the image's revision where the archive still has it."""
        if package not in self.versions:
            if package.startswith("linux-source"):
                wanted = self._version(self.versions["kernel"]).split("=")[1]
                listed = run(["apt-cache", "madison", package], f"ask apt for {package}", "this needs Debian's apt")
                same = [v for v in re.findall(r"\|\s*(\S+)\s*\|", listed) if v == wanted]
                version = same[0] if same else None
            else:
                version = None
            self.versions[package] = version or self._candidate(package)
            self._save_versions(self.versions)
        return f"{package}={self.versions[package]}"

    def _download(self, packages, folder):
        """Paths of the packages' files. apt checks them against the archive's signature."""
        wanted = [self._version(p) for p in packages]
        self.say(f"download {', '.join(wanted)}")
        command = ["apt-get", "-q", "-o", "APT::Sandbox::User=root", "-o", "Acquire::Retries=2", "download", *wanted]
        advice = f"connect to Debian's archive, or copy a filled cache to {self.folder} (ANNULUS_HIL_CACHE names another)"
        try:
            run(command, f"download {' '.join(wanted)}", advice, cwd=folder, timeout=1800)
        except HilError:
            self._update_lists()  # the lists may name a file that the archive has replaced
            run(command, f"download {' '.join(wanted)}", advice, cwd=folder, timeout=1800)
        return [os.path.join(folder, name) for name in sorted(os.listdir(folder)) if name.endswith(".deb")]

    def _unpack(self, packages, folder):
        """Downloads and unpacks packages into the folder."""
        downloads = folder + ".deb"
        os.makedirs(downloads)
        try:
            for path in self._download(packages, downloads):
                run(["dpkg-deb", "-x", path, folder], f"unpack {os.path.basename(path)}", "is the disk full?", timeout=600)
        finally:
            shutil.rmtree(downloads)

    # --- parts ------------------------------------------------------------------------------------------------------------

    def _part(self, name, made_of, make):
        """The folder of a part, made by `make(temporary folder)` unless it is there and made of the same."""
        folder = os.path.join(self.folder, name)
        stamp = "\n".join(made_of) + "\n"
        if self._stamp(folder) == stamp:
            return folder
        new = folder + ".new"
        for leftover in (new, new + ".deb", folder):
            shutil.rmtree(leftover, ignore_errors=True)
        os.makedirs(new)
        make(new)
        with open(os.path.join(new, "stamp"), "w", encoding="utf-8") as f:
            f.write(stamp)
        os.rename(new, folder)
        return folder

    @staticmethod
    def _stamp(folder):
        try:
            with open(os.path.join(folder, "stamp"), encoding="utf-8") as f:
                return f.read()
        except FileNotFoundError:
            return ""

    def _image(self):
        return self._part("image", [self._version(self.versions["kernel"])], self._make_image)

    def _make_image(self, folder):
        root = os.path.join(folder, "root")
        self._unpack([self.versions["kernel"]], root)
        self.say("unpack the kernel")
        with open(os.path.join(root, "boot", f"vmlinuz-{self.release}"), "rb") as f:
            packed = f.read()
        with open(os.path.join(folder, "vmlinux"), "wb") as f:
            f.write(unpack_bzimage(packed))
        depmod(root, self.release)

    def _headers(self):
        release = self.release
        packages = [f"linux-headers-{release}", f"linux-headers-{release.removesuffix('amd64')}common", self._kbuild()]

        def make(folder):
            self._unpack(packages, folder)
            # The packages' makefile names its other half by its installed place.
            path = os.path.join(folder, f"usr/src/linux-headers-{release}/Makefile")
            with open(path, encoding="utf-8") as f:
                text = f.read()
            final = os.path.join(self.folder, "headers")
            with open(path, "w", encoding="utf-8") as f:
                f.write(text.replace("/usr/src/", f"{final}/usr/src/"))

        made_of = [self._version(p) for p in packages] + [self.folder]
        return os.path.join(self._part("headers", made_of, make), f"usr/src/linux-headers-{release}")

    def _kbuild(self):
        return f"linux-kbuild-{self._series()}"

    def _series(self):
        """Major and minor of the kernel, as in the source package's name."""
        return ".".join(self.release.split(".")[:2])

    def _source(self):
        package = f"linux-source-{self._series()}"

        def make(folder):
            unpacked = folder + ".unpacked"
            shutil.rmtree(unpacked, ignore_errors=True)
            try:
                self._unpack([package], unpacked)
                self.say("unpack the drivers' source")
                archive = os.path.join(unpacked, f"usr/src/{package}.tar.xz")
                run(["tar", "-xJf", archive, "--strip-components=1", "--wildcards", *(f"{package}/{f}" for f in SOURCE_FILES)],
                    f"unpack {package}", "is the disk full?", cwd=folder, timeout=600)
            finally:
                shutil.rmtree(unpacked, ignore_errors=True)

        return self._part("source", [self._version(package), *SOURCE_FILES], make)

    def _modules(self):
        headers, source = self._headers(), self._source()
        recipe = hashlib.sha256(repr((KBUILD, IRQ_SIM_EDITS, IRQ_SIM_TAIL)).encode()).hexdigest()
        made_of = [self._stamp(source), self._stamp(os.path.join(self.folder, "headers")), recipe]
        return self._part("modules", made_of, lambda folder: self._make_modules(folder, headers, source))

    def _make_modules(self, folder, headers, source):
        for place in ("drivers/gpio", "kernel/irq", "drivers/net/can/ctucanfd"):
            shutil.copytree(os.path.join(source, place), folder, dirs_exist_ok=True)
        shutil.rmtree(os.path.join(folder, "Makefile"), ignore_errors=True)
        with open(os.path.join(folder, "irq_sim.c"), encoding="utf-8") as f:
            text = f.read()
        for old, new in IRQ_SIM_EDITS:
            text = text.replace(old, new)
        for name, content in (("irq_sim.c", text + IRQ_SIM_TAIL), ("Makefile", KBUILD)):
            with open(os.path.join(folder, name), "w", encoding="utf-8") as f:
                f.write(content)
        self.say("build gpio-sim and ctucanfd")
        run(["make", "-C", headers, f"M={folder}", "-j2", "modules"], "build gpio-sim and ctucanfd",
            "look into tests/hil/debian_kernel.py: the kernel's source may have changed", timeout=1200)

    def _make_tree(self, folder):
        """The image's modules by hard links, and ours beside them."""
        shutil.copytree(os.path.join(self._image(), "root", "lib"), os.path.join(folder, "lib"), copy_function=os.link, symlinks=True)
        modules = os.path.join(folder, "lib/modules", self.release)
        for name in os.listdir(modules):
            if name.startswith("modules."):  # depmod rewrites its tables: they must not be shared with the image's
                path = os.path.join(modules, name)
                shutil.copy(path, path + ".own")
                os.rename(path + ".own", path)
        os.makedirs(os.path.join(modules, "updates"))
        for name in BUILT_MODULES:
            shutil.copy(os.path.join(self.folder, "modules", f"{name}.ko"), os.path.join(modules, "updates"))
        depmod(folder, self.release)


def depmod(root, release):
    run(["/usr/sbin/depmod", "-b", root, release], "depmod", "install Debian's kmod", timeout=300)


def unpack_bzimage(packed):
    """The ELF kernel inside a bzImage that is packed with xz, as Debian's is."""
    start = packed.find(b"\xfd7zXZ\x00")
    while start >= 0:
        try:
            kernel = lzma.LZMADecompressor(lzma.FORMAT_XZ).decompress(packed[start:])
            if kernel.startswith(b"\x7fELF"):
                return kernel
        except lzma.LZMAError:
            pass  # the magic number by chance, in code
        start = packed.find(b"\xfd7zXZ\x00", start + 1)
    raise HilError("unpack the kernel: no xz stream with an ELF file in it: Debian may pack its kernel otherwise now: mend unpack_bzimage")


def load_order(root, release, names):
    """Paths of the modules to be loaded one after the other for these names; without those built into the kernel."""
    paths = []
    for name in names:
        told = run(["/usr/sbin/modprobe", "-d", root, "-S", release, "--show-depends", name], f"find the module {name}",
                   "install Debian's kmod; delete the cache folder if it is damaged", timeout=60)
        for line in told.splitlines():
            words = line.split()
            if words and words[0] == "insmod" and words[1] not in paths:
                paths.append(words[1])
    return paths
