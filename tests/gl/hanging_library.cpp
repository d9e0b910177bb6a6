// Stands for a driver that waits for ever for a device.
#include <unistd.h>

__attribute__((constructor)) static void hang() {
  for (;;) pause();
}
