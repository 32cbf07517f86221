"""Who is here, from a visitor's offer to what all pages are told. No sockets and no aiortc here.

- Coming in: `entry` asks `wax.access` who somebody is, `capacity` whether they may connect,
  and `wax.streams` whether there is upload for them; `viewers` lists those who are here, and each
  second `room` sends away who may not stay.
- Acts: `viewer` (of one page), `host_acts` and `host_decisions`, `stop_budget`, `voices`,
  `proof_runner`.
- Told to pages: `page_messages` says what, `room_updates` when; `equipment`, `diagnosis`, `names`.
- Told to others: `record_keeper` to the records and to `event_maker`, which makes events,
  with those of `changes`, for `wax.hooks`; `tape_keeper`; `house_states`; `status` to programs
  that ask.
- Kept over a restart: `kept_state`.
- In a room of LiveKit: `rooms`, with the seats there (`room_seats`).
- Rates and measures: `token_bucket`, `minute_limits`, `last_wins`, `last_minute`, `spread`,
  `link_statistics`; names that look alike: `lookalikes`.

`room` connects them all. Decisions about driving are in `wax.control`, about media in
`wax.streams`.
"""
