// Interruption by SIGINT, SIGTERM or SIGHUP as a stop token, which the program passes to all work
// that it starts: long loops ask it and unwind through their destructors, so that temporary files
// go and the program ends with a status that tells which signal it was.
//
// No command takes longer than that: if the program has not ended kGraceMs after the first signal
// (it compresses a chunk of 128 MiB, or clears gigabytes), the handler itself removes the temporary
// files, prints the line and ends the process with the same status. Files appear whole or not at
// all, so nothing is lost that an orderly end would have kept.
#pragma once

#include "src/base/threads/stop_token.h"

namespace sluice {

inline constexpr int kGraceMs = 500;

// Installs the handlers. A second signal ends the process at once, and removes the temporary files
// first. A signal that is ignored already (nohup) stays so. Called once, by main.
void watchForInterruption();
// The exit status as shells count: 128 and the signal's number, 130 for SIGINT, 143 for SIGTERM,
// 129 for SIGHUP. 0 as long as no signal has come.
int interruptionStatus();
// A token that is asked to stop once a signal has come.
StopToken interruption();

// The line on standard error when a signal has ended the program: "interrupted" until a command
// sets a better one. Null: nothing. Null prints nothing.
void sayWhenInterrupted(const char* line);
const char* interruptedLine();

}  // namespace sluice
