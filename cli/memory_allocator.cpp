// Read by jemalloc when the program starts. Networks allocate and free the same hundreds of
// megabytes over and over; keeping them, in huge pages, spares their faults.
extern "C" {
__attribute__((visibility("default"))) const char* malloc_conf =
    "thp:always,dirty_decay_ms:-1,muzzy_decay_ms:-1,oversize_threshold:0";
}
