// What host/albedo/integrator.cpp and albedo.cl agree on.
enum albedo_strategy {
    OWN,        // the component's own sampler alone
    CLIPPED,    // own sampler, with u1 from above where wi meets the horizon
    OWN_SHARED, // own sampler, weighed against the horizon's
    HORIZON,    // the horizon's sampler, weighed against the component's own
    STRATEGIES  // a task's second word is strategy + STRATEGIES * power
};
enum {
    STEPS = 8 // evenly spaced points along u1 that share the search for where wi meets the horizon
};
// A group's sums, and the values that tell how a component behaves at the horizon.
enum albedo_sum { ALBEDO_ALL, ALBEDO_WEIGHTED, ALBEDO_SUMS };
enum horizon_value { VALUE_NEAR, VALUE_NEARER, HORIZON_VALUES };
// wi.z of those.
#define NEAR 1e-12f
#define NEARER 1e-18f
