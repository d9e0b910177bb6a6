// runInChild: runs work that may crash or hang in a child process and brings back its answer.
//
// A graphics driver runs in our process with our memory; a broken one takes the program with it. So
// the question is asked in a forked child, whose answer comes through a pipe; the child is killed
// when it is late, and when this process ends before it. Its standard output and error go nowhere.
//
// Requires: no thread of this process holds a lock that `work` needs (best: there are no other
// threads), and no GL library has made a context in this process, since the child inherits its
// state without its threads.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace sluice {

struct ChildAnswer {
  bool answered = false;  // `work` returned, and all of its answer arrived
  std::string answer;
  std::string reason;  // otherwise: the exception's text, "crashed (Segmentation fault)", ...
};

// Throws Error only when no process or pipe can be made.
ChildAnswer runInChild(const std::function<std::string()>& work, std::chrono::milliseconds timeout);

}  // namespace sluice
