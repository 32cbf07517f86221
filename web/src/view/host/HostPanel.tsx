import "../../style/host.css";
import { said } from "../../words/said";
import { useState } from "../context";
import { ProofPanel } from "../ProofPanel";
import { Admission } from "./Admission";
import { Calibration } from "./Calibration";
import { Frame } from "./Frame";
import { Hosts } from "./Hosts";
import { Invitation } from "./Invitation";
import { Message } from "./Message";
import { People } from "./People";
import { Pressers } from "./Pressers";
import { Turns } from "./Turns";

/** Only for the host: the people here, the queue, admission and more. */
export function HostPanel() {
  const { isHost, console } = useState();
  if (!isHost.value) return null;
  return (
    <div class="host">
      {console.value?.problems.map(said).map((one) => (
        <p key={one} role="status">
          {one}
        </p>
      ))}
      <People />
      <Pressers />
      <Turns />
      <Admission />
      <Hosts />
      <Invitation />
      <Frame />
      <Message />
      <Calibration />
      <ProofPanel />
    </div>
  );
}
