// Read by jemalloc when the program starts. Networks allocate and free the same hundreds of
// megabytes over and over; keeping them for a while, in huge pages, spares their faults. What no
// step of the last half minute needed is given back, or long trainings would keep growing: no two
// scans ask for the same sizes.
extern "C" {
__attribute__((visibility("default"))) const char* malloc_conf =
    "thp:always,dirty_decay_ms:30000,muzzy_decay_ms:0,oversize_threshold:0";
}
