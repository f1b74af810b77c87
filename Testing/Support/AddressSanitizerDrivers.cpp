// Mesa's driver goes with the last OpenGL context, and what it had allocated is then reported as leaked, without a name
// to tell it from our own leaks. So nothing is unloaded.
extern "C" int dlclose(void*)
{
  return 0;
}
