// Uses the generated types against the service at GYROWATCH_URL, which must be empty: 0 where all is as it should be.

import createClient from "openapi-fetch";
import type { components, paths } from "./gyrowatch.js";

declare const process: { env: Record<string, string>; exitCode: number };
declare function require(name: "fs"): { readFileSync(path: string, coding: "utf8"): string };

const { GYROWATCH_URL: baseUrl, GYROWATCH_TOKEN: token, GYROWATCH_TEST_DATA: data } = process.env;
const api = createClient<paths>({ baseUrl: baseUrl!, headers: { Authorization: `Bearer ${token}` } });
const read = (name: string) => JSON.parse(require("fs").readFileSync(`${data}/${name}`, "utf8"));

function same(found: unknown, expected: unknown): void {
  const [a, b] = [JSON.stringify(found), JSON.stringify(expected)];
  if (a !== b) throw new Error(`${a} is not ${b}`);
}

function there<T>(answer: { data?: T; error?: components["schemas"]["Problem"] }): NonNullable<T> {
  if (answer.data === undefined || answer.data === null) throw new Error(answer.error?.detail);
  return answer.data;
}

async function use(): Promise<void> {
  const record: components["schemas"]["RecordBody"] = read("paper.json");
  for (const calibrated_at of ["2026-03-01T08:00:00Z", "2026-03-02T08:00:00Z"]) {
    there(await api.POST("/v1/records", { body: { ...record, calibrated_at } }));
  }

  const seen: string[] = [];
  let cursor: string | null = null;
  do {
    const query = { imu: record.imu, limit: 2, ...(cursor === null ? {} : { cursor }) };
    const page: components["schemas"]["Gyros"] = there(await api.GET("/v1/gyros", { params: { query } }));
    for (const gyro of page.gyros) {
      seen.push(gyro.serial);
      same(gyro.latest?.calibrated_at, "2026-03-02T08:00:00Z");
    }
    cursor = page.next;
  } while (cursor !== null);
  same(seen, record.gyros.map((gyro) => gyro.serial));

  const path = { serial: seen[0]! };
  const trend = there(await api.GET("/v1/gyros/{serial}/trend", { params: { path, query: { coefficient: "D_I" } } }));
  if (typeof trend === "string" || !("points" in trend)) throw new Error("no points");
  same(trend.points.map((point) => point.value.toFixed(6)), ["2.957643", "2.957643"]);

  const stored = there(await api.POST("/v1/campaigns", { body: read("practice/campaign-00.json") }));
  const of = { params: { path: { id: stored.id! } } };
  const diagnosis = there(await api.GET("/v1/campaigns/{id}/diagnosis", of));
  if (!diagnosis.verdict) throw new Error("no verdict");

  const far = { ...record, calibrated_at: "2999-01-01T00:00:00Z" };
  const { error, response } = await api.POST("/v1/records", { body: far });
  const places = error?.errors?.map(({ pointer, code }) => [pointer, code]);
  same([response.status, places], [422, [["/calibrated_at", "time_in_future"]]]);
}

use().then(
  () => console.log("used from TypeScript"),
  (why) => {
    console.log(why);
    process.exitCode = 1;
  },
);
