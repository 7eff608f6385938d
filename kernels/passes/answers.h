// Functions whose values a device is asked for: host/device/probe.cpp, answers.cl.
enum { ANSWERS = 8 };
