"""The Vulkan devices of this machine and their drivers' versions, asked of the loader itself.

`python -m wmspec.execute.vulkan` prints them as JSON; a process of its own, because drivers may crash. Structures and
constants are those of the Vulkan 1.2 specification (VkPhysicalDeviceProperties2, VkPhysicalDeviceDriverProperties).
"""

from __future__ import annotations

import ctypes
import json
import re
from ctypes import POINTER, byref, c_char, c_char_p, c_uint8, c_uint32, c_void_p
from dataclasses import asdict, dataclass

LOADERS = ("libvulkan.so.1", "libvulkan.so")
VERSION_1_2 = (1 << 22) | (2 << 12)
LAVAPIPE = 13  # VK_DRIVER_ID_MESA_LLVMPIPE


@dataclass(frozen=True)
class Device:
    """A Vulkan device: its name, its driver's number, name and own version text, such as "Mesa 25.0.7"."""

    name: str
    driver_id: int
    driver: str
    info: str

    @property
    def mesa(self) -> tuple[int, int] | None:
        """Mesa's major and minor version, or None for another driver."""
        match = re.search(r"Mesa (\d+)\.(\d+)", self.info)
        return (int(match[1]), int(match[2])) if match else None

    def draws(self, since: tuple[int, int]) -> bool:
        """Whether an engine can draw with it: any GPU's driver, or Mesa's software driver from a version on."""
        return self.driver_id != LAVAPIPE or (self.mesa or (0, 0)) >= since

    def __str__(self) -> str:
        return f"{self.name}, {self.driver} {self.info}"


class _Application(ctypes.Structure):
    _fields_ = (
        ("type", c_uint32),
        ("next", c_void_p),
        ("name", c_char_p),
        ("version", c_uint32),
        ("engine", c_char_p),
        ("engine_version", c_uint32),
        ("api", c_uint32),
    )


class _Create(ctypes.Structure):
    _fields_ = (
        ("type", c_uint32),
        ("next", c_void_p),
        ("flags", c_uint32),
        ("application", POINTER(_Application)),
        ("layer_count", c_uint32),
        ("layers", c_void_p),
        ("extension_count", c_uint32),
        ("extensions", c_void_p),
    )


class _Driver(ctypes.Structure):
    _fields_ = (
        ("type", c_uint32),
        ("next", c_void_p),
        ("id", c_uint32),
        ("name", c_char * 256),
        ("info", c_char * 256),
        ("conformance", c_uint8 * 4),
    )


class _Properties(ctypes.Structure):
    _fields_ = (
        ("type", c_uint32),
        ("next", c_void_p),
        ("numbers", c_uint32 * 5),
        ("name", c_char * 256),
        ("rest", c_uint8 * 1024),  # identifiers and limits, 548 bytes, which we don't read
    )


def devices() -> tuple[Device, ...]:
    """All devices of all installed drivers. Raises OSError if there is no loader or no driver."""
    vulkan = _loader()
    application = _Application(type=0, api=VERSION_1_2)
    instance = c_void_p()
    create = _Create(type=1, application=ctypes.pointer(application))
    if code := vulkan.vkCreateInstance(byref(create), None, byref(instance)):
        raise OSError(f"vkCreateInstance failed with {code}: no driver")
    try:
        count = c_uint32()
        vulkan.vkEnumeratePhysicalDevices(instance, byref(count), None)
        handles = (c_void_p * count.value)()
        vulkan.vkEnumeratePhysicalDevices(instance, byref(count), handles)
        return tuple(_device(vulkan, handle) for handle in handles)
    finally:
        vulkan.vkDestroyInstance(instance, None)


def _loader() -> ctypes.CDLL:
    for name in LOADERS:
        try:
            return ctypes.CDLL(name)
        except OSError:
            continue
    raise OSError(f"{LOADERS[0]}, the Vulkan loader, is not installed")


def _device(vulkan: ctypes.CDLL, handle: int | None) -> Device:
    driver = _Driver(type=1000196000)
    properties = _Properties(type=1000059001, next=ctypes.addressof(driver))
    vulkan.vkGetPhysicalDeviceProperties2(c_void_p(handle), byref(properties))
    texts = (properties.name.decode(), int(driver.id), driver.name.decode(), driver.info.decode())
    return Device(*texts)


if __name__ == "__main__":
    try:
        print(json.dumps({"devices": [asdict(d) for d in devices()], "missing": ""}))
    except OSError as failure:
        print(json.dumps({"devices": [], "missing": str(failure)}))
