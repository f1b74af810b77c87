// Mesa's driver goes with the last OpenGL context, and what it had allocated is then reported as leaked, without a name
// to tell it from our own leaks. So nothing is unloaded.
extern "C" int dlclose(void*)
{
  return 0;
}

/// The search for leaks may crash on what it knows of the driver's thread-local variables (GCC 12).
extern "C" const char* __asan_default_options()
{
  return "intercept_tls_get_addr=0";
}
