// The rule for redirects: a request stays at the server that the user named.
#pragma once

#include <string>

namespace sluice {

// "https://host:port" of an absolute address, without user, path and query, in lower case and
// without the scheme's own port. Empty: it is no address of http or https.
std::string originOf(const std::string& url);

// Returns why a redirect from one address to another is not followed; empty: it is followed. Only
// the same server is asked, and its https in place of its http if there is nothing secret to send.
// The line names the other server, never a path or query, which may hold a key.
std::string redirectFault(const std::string& from, const std::string& to, bool has_credentials);

}  // namespace sluice
