# What cannot be done or shown, by code; titles of problems.

## Titles

title_no_such_record = No such record
title_no_such_campaign = No such campaign
title_no_such_bench_result = No such bench result
title_no_such_hook = No such hook
title_no_such_delivery = No such delivery
title_no_such_token = No such token
title_no_such_diagnoses = No such diagnoses
title_no_such_reference = No such reference
title_no_such_path = No such path
title_no_such_page = No such page
title_unknown_gyro = Unknown gyro
title_unknown_imu = Unknown IMU
title_unknown_alert = Unknown alert
title_unknown_silence = Unknown silence
title_differs = Already stored with other content
title_key_reused = Idempotency-Key used for other content
title_gyro_elsewhere = Gyro calibrated elsewhere at the same time
title_already_corrected = Already voided or revised
title_not_set_aside = Not set aside
title_nothing_to_adopt = Nothing to adopt or undo
nothing_to_adopt = the diagnosis of campaign { $id } names nothing, or is still being made
no_model_to_undo = no model was adopted for IMU { $imu }
title_cannot_be_stored = Cannot be stored as it is
title_time_taken = Another calibration at that time
title_other_station = Token of another station
title_token_not_valid = Token not valid
title_token_needed = Token needed
title_not_allowed = Not allowed
title_try_again = Try again
title_hook_disabled = Hook disabled
title_not_its_turn = Not its turn
title_delivery_dropped = Dropped
title_too_many_hooks = Too many hooks
title_diagnoses_ended = Diagnoses have ended
title_no_such_hypothesis = No such hypothesis
title_hypothesis_taken = Another hypothesis has this name
title_too_many_hypotheses = Too many hypotheses
title_too_many_silences = Too many silences
title_alert_resolved = Alert is resolved
title_no_room = No room left
title_cannot_store = Cannot store
title_perhaps_stored = Perhaps stored
title_damaged_database = Damaged database
title_internal_error = Internal error
title_not_json = Not JSON
title_unsupported_media_type = Unsupported media type
title_bad_idempotency_key = Bad Idempotency-Key
title_bad_query = Bad query
compare_what = select 2 to { $most } gyros in the fleet, or two campaigns on the page of their IMU
title_too_large = Too large
title_broken_off = Broken off
title_foreign_page = Foreign page
title_other_name = Not this machine's name
title_too_many_wrong_tokens = Too many wrong tokens
title_too_many_requests = Too many requests
title_not_ready = Not ready
title_nothing_to_diagnose = Nothing to diagnose
title_no_reference = Not usable as reference
title_unknown_transfer_coding = Unknown transfer coding
title_two_hosts = Two hosts
title_no_host = No host

## What is not there

faults_in_document = the document has faults
unknown_gyro = no gyro has the serial { $serial }
unknown_imu = no IMU is named { $imu }
unknown_imu_like = no IMU is named { $imu }; did you mean { $known }?
unknown_station = no station is named { $station }
no_such_record = there is no record { $id }
no_such_campaign = there is no campaign { $id }
no_such_reference = there is no campaign or record { $id }
no_such_bench_result = there is no bench result { $id }
no_such_hook = there is no hook { $id }
no_such_delivery = there is no delivery { $id }
no_such_token = there is no token { $id }
no_such_diagnoses = there is no order of diagnoses { $id }
unknown_alert = there is no alert { $id }
unknown_silence = there is no silence { $id }
no_such_path = nothing is served at { $path }
not_done_to_alerts = alerts have no action "{ $action }"

## What stands in the way

differs = an item with the same key is stored with other content (id { $id }); they differ at { $places }
differs_further = an item with the same key is stored with other content (id { $id }); they differ at { $places } … and { $further } more
differs_in_everything = an item with the same key is stored with other content (id { $id }); they differ in everything, as a record and a campaign do
differs_here = differs from what is stored
key_reused = the Idempotency-Key was used before for other content (id { $id })
gyro_elsewhere = gyro { $serial } has another calibration at the same time (id { $id })
already_corrected = { $id } has been voided or revised already
corrected_otherwise = { $id } has been voided or revised already: by another author, for another reason or by other content
not_set_aside = { $id } is not set aside: there is nothing to confirm
another_imu = belongs to another IMU than the item that it replaces
time_taken = the IMU has another calibration at that time (id { $id })
other_station = the token is only for the station { $station }
setup_over = a token has been created, so the setup secret is no longer valid
no_random_numbers = the operating system gives no random numbers
hook_disabled = hook { $id } is disabled; enable it first
delivery_dropped = delivery { $id } was dropped: what still fires was told anew
still_behind = delivery { $id } has not had its turn yet: an earlier one of the same alert comes first
secret_needed = a standard-webhooks hook always signs: send a new secret instead
target_of_other_kind = a hook of kind email has a mailto: address, any other http:// or https://
too_many_hooks = there are already { $most } hooks, the most there can be
diagnoses_ended = order { $id } of diagnoses has ended: there is nothing to cancel
no_such_hypothesis = no hypothesis { $name } competes
hypothesis_taken = another hypothesis { $name } competes: take it out first, or give this one another id
hypotheses_too_many = { $most } hypotheses compete, which is the most: take one out first
alert_resolved = alert { $id } is resolved: there is nothing to acknowledge
too_many_silences = there are already { $most } silences in force, the most there can be
event_there = an event of this kind is already stored at that time with another reason
baseline_there = a baseline already begins at that time for another reason

## The service itself

busy = too many writes are waiting
stopping = the service is stopping
disk_full = the service's disk is full; nothing was stored
cannot_write = the service's database cannot be written now; nothing was stored
perhaps_stored = the database connection broke while this was stored, so it may or may not be stored. Measurements can be sent again. Before you repeat other orders (hooks, tokens), check whether they took effect
disk_failed = the service's disk failed; nothing is accepted until it is repaired
database_damaged = the database is damaged: { $what }
store_no_database = the file is no SQLite database ({ $why })
service_failed = the service failed; its log says why
body_not_json = the stored body of { $id } is not JSON
body_unreadable = the stored body of { $id } cannot be read
audit_not_json = line { $id } of the audit trail is not JSON
not_fitted = the campaign could not be fitted
token_lost = the token was created but cannot be read back; revoke it
model_lost = the model was adopted and cannot be read back; the log says why
not_written = the answer could not be written
line_not_answered = the line was not answered
line_not_read = the line was not read
not_reading = reading: { $why }
not_writing = writing: { $why }
writer_silent = the writer has not answered for { $seconds } s
no_delivery_worker = the delivery worker is not running
answer_took_too_long = the answer took too long; try again later

## Requests

wrong_method = this path does not take that method; see Allow
path_not_utf8 = the path is not UTF-8: write each byte of a name in UTF-8 that is no letter or digit as %XX
too_long_body = a body may have { $most } bytes, the limit that { $key } sets
too_long_import = an import may have { $most } bytes, the limit that { $key } sets; what came before this line is answered
too_long_line = a line may have { $most } bytes, the limit that { $key } sets
belongs_to_records = this is a calibration record: send it to /v1/records
belongs_to_campaigns = this is a campaign of raw dwells: send it to /v1/campaigns
belongs_to_bench_results = this is a bench result: send it to /v1/bench-results
content_type_missing = Content-Type must be { $wanted }, but is missing
content_type = Content-Type must be { $wanted }, is { $found }
content_type_charset = JSON is UTF-8, not { $charset }: convert the body and leave the charset out of Content-Type
content_encoding = Content-Encoding { $encoding } is not accepted; send the body as it is, or as gzip
body_broke_off = the body broke off: it did not arrive whole, or is not the gzip that its header says
idempotency_key_form = must be 1 to 255 visible ASCII characters
idempotency_key_not_taken = no Idempotency-Key is taken here: only records, campaigns and bench results have one. Send without it, and look in the list before you send again
parameter_one_of = { $parameter } must be one of { $known }, is { $value }
unknown_parameter = unknown parameter `{ $parameter }`; the parameters are { $known }
no_parameters = unknown parameter `{ $parameter }`; no parameters are taken here
parameter_twice = { $parameter } is given twice
parameter_missing = { $parameter } is missing
parameter_whole = { $parameter } must be a whole number
parameter_number = { $parameter } must be a number
parameter_flag = { $parameter } must be true or false
form_unreadable = the form cannot be read
query_unreadable = the query of the address cannot be read
parameter_range = { $parameter } must be { $least } to { $most }, is { $value }
parameter_fault = { $parameter }: { $fault }
every_counts_only = every cannot be used with voided=include or levels=include
columns_of_json = columns cannot be used with format=csv or every
last_alone = last cannot be used with limit or cursor
from_after_to = from is after to
invalid_cursor = invalid cursor
cursor_of_other_list = this cursor belongs to another list or another order; take `next` of the page before
transfer_coding = Transfer-Encoding must be chunked, once, where there is one
one_host = there must be one Host
host_needed = HTTP/1.1 needs a Host

## Who may do what

no_token = a token is needed: send Authorization: Bearer, or sign in
not_here = no token has been created yet; until then the service answers this machine only
proxied = a reverse proxy is in front and no token has been created yet, so anyone could be asking: create one with `gyrowatch token create NAME --role admin`
wrong_token = unknown token
revoked_token = the token was revoked
expired_token = the token has expired
signed_out = the session has ended; sign in again
too_many_failures = too many wrong tokens came from this address
too_many_requests = this token sends more requests per second than it may
access_unreadable = access rights cannot be read now
role_needed = the role { $needed } is needed; the token has the role { $role }
first_token_needed = a token of the role { $role } is needed, and none exists yet. Create the first with `gyrowatch token create NAME --role admin`, or send the setup secret from the log as Authorization: Bearer
foreign_page = the request was sent by a page of another site
other_name = until the first token is created, the service answers only under localhost and loopback addresses: a page of another site could use any other name

## How sending to a hook went

address_refused = { $address } is refused: { $why }
outside_networks = it is in none of the configured networks
loopback_refused = loopback is allowed only while the service itself listens on loopback
leads_to_the_proxy = through a proxy it leads to the proxy's own machine or its credentials
cloud_credentials = it is where cloud machines keep their credentials
link_local = link-local addresses hold cloud metadata
no_destination = it is not a destination
no_single_host = it is not a single host
name_unknown = { $name } does not resolve: { $why }
name_empty = { $name } resolves to no address
name_forbidden = { $name } resolves to a forbidden address: { $why }
target_gone = the target answered 410 Gone at { $at }
redirected = answered { $status } to { $to }: redirects are not followed, name the final address
answered = answered { $status }
with_answer = { $what }: { $answer }
answered_but = answered { $status }, but { $why }
answer_not_object = the answer is not a JSON object
answer_lacks = { $member } is missing
answer_differs = { $member } is { $value }, not { $wanted }
answer_cut = the answer was cut off after { $bytes } bytes
answer_broke_off = the answer broke off: { $why }
answer_did_not_end = the answer did not end within { $seconds } s
no_connection_within = no connection within { $seconds } s
no_answer_in_time = it does not answer in time
no_answer_within = no answer within { $seconds } s
no_mail_server = no mail server is configured: set hooks.smtp_url and hooks.mail_from
mail_failed = the mail server: { $why }
recipient_not_served = { $recipient }: { $why }
tls_failed = TLS failed: { $why }
no_connection = no connection: { $why }
no_http_answer = no HTTP answer: { $why }
file_not_found = No such file or directory (os error { $number })
file_exists = File exists (os error { $number })
permission_denied = Permission denied (os error { $number })
is_a_directory = Is a directory (os error { $number })
not_a_directory = Not a directory (os error { $number })
read_only_files = Read-only file system (os error { $number })
no_space_left = No space left on device (os error { $number })
address_in_use = Address already in use (os error { $number })
connection_refused = nothing listens there (connection refused, os error { $number })
connection_reset = the other side broke off the connection (os error { $number })
no_route_to_host = no way leads to this host (os error { $number })
no_route_to_network = no way leads to this network (os error { $number })
certificate_of_unknown_authority = the certificate is signed by an authority that this machine does not know; give its certificate in hooks.ca_file, to `import` in --ca-file
certificate_of_an_authority = what is shown is the certificate of an authority (CA:TRUE), as plain `openssl req -x509` makes it. Give it a server's: `-addext basicConstraints=critical,CA:FALSE`, or one that an authority has signed
certificate_not_in_time = the certificate is not valid today; compare its dates with this machine's clock
certificate_for_other_name = the certificate is for another host name
no_tls_there = what answers does not speak TLS; perhaps http:// is meant
hung_up = the connection was closed before the answer
not_http = what answers does not speak HTTP
no_such_name = no such name
no_name_server = no name server answers this machine
stored_message_unreadable = the stored message cannot be read: { $why }
stored_message_empty = it holds no alert
end_of_what_was_never_told = it tells the end of what the target was never told: not sent
header_control_character = a header would contain a control character

## Diagnoses and events

computation_broke_off = its computation broke off; the service's log says why
event_needed = choose an event

## Several at once

several = { $faults }
no_alert_selected = no alert is selected
