"""The exceptions that the package raises."""


class InputError(ValueError):
    """Bad input: an argument, a file or a material that is not as expected.

    The message names the argument or the file, the place in it and what was expected.
    """


class DeviceError(RuntimeError):
    """No OpenCL device, or one that fails.

    Where there is none, the message names the package to install.
    """
