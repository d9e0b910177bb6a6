// Interruption by SIGINT, SIGTERM or SIGHUP as a stop token, which the program hands to what it
// starts: long loops ask it and unwind through their destructors, so that temporary files go and
// the program ends with a status that says which it was.
#pragma once

#include "src/base/stop_token.h"

namespace sluice {

// Installs the handlers; a second signal ends the process at once. A signal that is ignored
// already (nohup) stays so. Called once, by main.
void watchForInterruption();
// As shells count: 128 and the signal's number, 130 for SIGINT, 143 for SIGTERM, 129 for SIGHUP. 0
// as long as none has come.
int interruptionStatus();
// Asked to stop once a signal has come.
StopToken interruption();

}  // namespace sluice
