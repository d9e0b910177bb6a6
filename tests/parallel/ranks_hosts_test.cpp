// Ranks on several hosts, which are network namespaces here, one each, with nothing between them
// but a cable: the launcher reaches the other by an agent in the place of ssh, ranks meet over TCP.
#include <unistd.h>

#include "tests/parallel/ranks_program.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Two namespaces and a pair of network devices; gone with the object.
class Hosts {
 public:
  Hosts() : names_{fmt::format("sluice{}a", getpid()), fmt::format("sluice{}b", getpid())} {
    if (geteuid() != 0 || !haveProgram("ip") || !haveProgram("unshare")) {
      missing_ = "network namespaces need root, ip and unshare";
      return;
    }
    std::string line = "set -e; ";
    for (const std::string& name : names_) line += fmt::format("ip netns add {}; ", name);
    line += fmt::format("ip link add e0 netns {} type veth peer name e0 netns {}; ", names_[0],
                        names_[1]);
    for (size_t i = 0; i < 2; ++i)
      line += fmt::format(
          "ip -n {0} addr add {1}/24 dev e0; ip -n {0} link set lo up; "
          "ip -n {0} link set e0 up; ",
          names_[i], address(i));
    const CommandResult made = runCommand(line);
    if (made.status != 0) missing_ = "network namespaces are not allowed here: " + made.output;
  }
  ~Hosts() {
    for (const std::string& name : names_)
      if (geteuid() == 0) runCommand(fmt::format("ip netns del {} 2>/dev/null || true", name));
  }
  Hosts(const Hosts&) = delete;
  Hosts& operator=(const Hosts&) = delete;

  const std::string& missing() const { return missing_; }
  const std::string& name(size_t host) const { return names_[host]; }
  static std::string address(size_t host) { return fmt::format("10.213.77.{}", host + 1); }
  // Bytes sent over the first host's cable.
  uint64_t sentBytes() const {
    const CommandResult read = runCommand(
        fmt::format("ip netns exec {} cat /sys/class/net/e0/statistics/tx_bytes", names_[0]));
    return std::stoull(read.output);
  }
  // A script that a launcher calls as `script HOST COMMAND...`.
  void writeAgent(const std::filesystem::path& path) const {
    writeFile(path, fmt::format("#!/bin/sh\nhost=$1; shift\n"
                                "case $host in {}) name={};; *) name={};; esac\n"
                                "exec ip netns exec $name unshare --uts "
                                "sh -c \"hostname $name; exec sh -c '$*'\"\n",
                                address(0), names_[0], names_[1]));
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }

 private:
  std::string names_[2];
  std::string missing_;
};

class RanksHosts : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string missing = kOpenMpiLauncher.missing(); !missing.empty())
      GTEST_SKIP() << "skipped: " << missing;
    if (!hosts_.missing().empty()) GTEST_SKIP() << "skipped: " << hosts_.missing();
    hosts_.writeAgent(program_.folder / "agent");
  }
  CommandResult onHosts(const std::string& arguments) const {
    const std::string line = fmt::format(
        "cd {0} && export XDG_CACHE_HOME={0}/cache && hostname {1} && "
        "timeout -k 5 120 {2} {3} --mca plm_rsh_agent {0}/agent --mca btl tcp,self "
        "--mca btl_tcp_if_include 10.213.77.0/24 --mca oob_tcp_if_include 10.213.77.0/24 "
        "--host {4}:2,{5}:2 -n 4 " SLUICE_PROGRAM " {6}",
        program_.folder.path().string(), hosts_.name(0), kOpenMpiLauncher.program(),
        kOpenMpiLauncher.options, Hosts::address(0), Hosts::address(1), arguments);
    return runCommand(
        fmt::format("ip netns exec {} unshare --uts sh -c {}", hosts_.name(0), shellQuoted(line)));
  }
  const OwnSessions sessions_;
  const Program program_;
  const Hosts hosts_;
};

TEST_F(RanksHosts, drawAPictureTogether) {
  const std::string picture = "render synth:shells,dims=80x80x80 --block 16 --size 160 ";
  program_.json(picture + "-o one.png");
  const CommandResult run = onHosts(picture + "-o many.png --json -q");
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_LE(pictureDifference(program_.folder / "one.png", program_.folder / "many.png"), 1);
  const json report = json::parse(run.output);
  ASSERT_EQ(report["ranks"].size(), 4U);
  EXPECT_EQ(report["ranks"][0]["host"], hosts_.name(0));
  EXPECT_EQ(report["ranks"][3]["host"], hosts_.name(1));
  EXPECT_GT(hosts_.sentBytes(), report["ranks"][0]["sent_bytes"].get<uint64_t>() / 2)
      << "over the cable";
}

TEST_F(RanksHosts, endTogether) {
  const CommandResult run = onHosts("render nothing.nrrd -o a.png");
  EXPECT_NE(run.status, 0);
  EXPECT_EQ(occurrences(run.output, "sluice: "), 1) << run.output;
  EXPECT_THAT(run.output, HasSubstr("nothing.nrrd: cannot be opened"));
}

}  // namespace
}  // namespace sluice
