// Chains of calls a work-item keeps going: bench/opencl.cpp, peaks.cl.
enum { CHAINS = 8 };
