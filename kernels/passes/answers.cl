// Values that are known, by which a driver is judged before it is trusted: functions of each x, and of each
// group the sum of the first.
__kernel __attribute__((reqd_work_group_size(LS, 1, 1))) void
answers(__global const real* x, uint count, __global real* out, __global float* sums)
{
    __local float scratch[LS];
    real sum = 0.0f;
    FOR_EACH_OF_RUN(i, count)
    {
        const real t = x[i];
        const real values[ANSWERS] = {exp(-t),
                                      log(t),
                                      sqrt(t),
                                      rsqrt(t),
                                      sin(t),
                                      cos(t),
                                      atan2(t, 2.0f - t),
                                      t > 1.0f ? fmin(t, 3.0f) : fmax(t * t, 0.5f)};
        for (int k = 0; k < ANSWERS; ++k)
            out[k * count + i] = values[k];
        sum += values[0];
    }
    write_group_sums(&sum, 1, scratch, sums + get_group_id(0));
}
