// Built without OpenCV: nothing to compare with.
// SPDX-License-Identifier: MIT
#include "firmware/peer.h"

namespace cupola {

std::unique_ptr<Peer> make_peer(const Rig&, std::span<const Image>, PeerFilter, WorkerPool&) {
  return nullptr;
}

}  // namespace cupola
