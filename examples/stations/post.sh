#!/bin/sh
# Send a file with curl; read the answer; try again where that can help.
#   GYROWATCH_URL=http://127.0.0.1:8080 GYROWATCH_TOKEN=... sh post.sh campaign.csv campaigns text/csv
file=$1 kind=${2:-campaigns} type=${3:-application/json}
url=${GYROWATCH_URL:-http://127.0.0.1:8080}/v1/$kind
[ -r "$file" ] || { echo "$file: cannot be read" >&2; exit 1; }
answer=$(mktemp) || exit 1
trap 'rm -f "$answer"' EXIT
# --retry waits as Retry-After says, on 408, 429 and 5xx, from curl 7.71 on also where the line drops;
# --data-binary sends the file byte for byte.
dropped=
curl --help all 2>/dev/null | grep -q -e --retry-all-errors && dropped=--retry-all-errors
language=${LC_ALL:-${LANG:-en}}
status=$(curl --silent --show-error --retry 5 --retry-connrefused $dropped --retry-max-time 600 --max-time 120 \
    ${GYROWATCH_TOKEN:+--header "Authorization: Bearer $GYROWATCH_TOKEN"} \
    --header "Accept-Language: ${language%%[_.@]*}" --header "Content-Type: $type" --data-binary "@$file" --output "$answer" --write-out '%{http_code}' "$url")
case $status in
200 | 201 | 202) cat "$answer"; echo; exit 0 ;;
000) echo "no answer at $url" >&2; exit 2 ;;
408 | 425 | 429 | 5??) echo "not taken ($status): $(cat "$answer")" >&2; exit 2 ;;
*) echo "refused ($status): $(cat "$answer")" >&2; exit 1 ;;
esac
