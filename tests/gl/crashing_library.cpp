// Stands for a driver that crashes as soon as it is opened.
#include <cstdlib>

__attribute__((constructor)) static void crash() {
  std::abort();
}
