"""Who is here, from a visitor's offer to the messages for all pages. No sockets, no aiortc.

- Admission: `entry` asks `wax.access` who somebody is, `capacity` whether they may connect
  (`newcomers`: who is next), and `wax.streams` whether there is upload for them; `viewers` lists
  who is here, and each second `presence` sends away viewers who may no longer stay, and notices
  who is lost.
- Acts: `viewer` (one page's), `host_acts`, `stop_budget`, `voices`, `proof_runner`.
- To pages: `page_messages` says what, `room_updates` when; `equipment`, `diagnosis`, `names`.
- To others: `record_keeper` writes the records and feeds `event_maker`, which adds the events of
  `changes` and sends all to `wax.hooks`; `tape_keeper`; `house_states`; `status` answers programs.
- Kept over a restart: `kept_state`.
- In LiveKit rooms: `rooms`, with the seats there (`room_seats`); `room_queue`.
- Measures of a link: `last_minute`, `link_statistics`;
  names that look alike: `lookalikes`.

`room` connects them all; what runs beside it is in one record, `parts`. Decisions about driving
are in `wax.control`, about media in `wax.streams`.
"""
