// Where the value of channel ch of sample i stands among `stride` samples a channel: with its chunk
// of channels side by side (a CPU), or each channel by itself. fit/samples.cpp, prepare.cl.
#define VALUE_IN_CHUNK(stride, i, ch, chunk)                                                       \
    (((ch) / (chunk) * (stride) + (i)) * (chunk) + (ch) % (chunk))
#define VALUE_IN_PLANE(stride, i, ch) ((ch) * (stride) + (i))
