# Send a file from Windows (PowerShell 5.1 or later); read the answer; try again where that can help.
#   $env:GYROWATCH_URL = 'http://service:8080'; .\post.ps1 campaign.csv campaigns text/csv
param([string]$File, [string]$Kind = 'campaigns', [string]$Type = 'application/json')
$url = "$(if ($env:GYROWATCH_URL) { $env:GYROWATCH_URL } else { 'http://127.0.0.1:8080' })/v1/$Kind"
# LC_ALL or LANG (zh_CN.UTF-8), or Windows, chooses the language of what is refused.
$language = "$env:LC_ALL $env:LANG $((Get-UICulture).Name)".Trim() -replace '[_.@ ].*$'
$headers = @{ 'Accept-Language' = $(if ($language -match '^[A-Za-z]{2}(-|$)') { $language } else { 'en' }) }
if ($env:GYROWATCH_TOKEN) { $headers['Authorization'] = "Bearer $env:GYROWATCH_TOKEN" }
$pauses = 1, 2, 5, 10, 30, 60, 60  # s, before it is sent again
for ($attempt = 0; ; $attempt++) {
    try {
        # -InFile sends the file byte for byte: no line end and no encoding changes.
        $answer = Invoke-RestMethod -Uri $url -Method Post -InFile $File -ContentType $Type -Headers $headers -TimeoutSec 120
        "stored as $($answer.id)"
        exit 0
    } catch {
        $status = 0
        if ($_.Exception.Response) { $status = [int]$_.Exception.Response.StatusCode }
        if ($status -ge 400 -and $status -lt 500 -and $status -notin 408, 425, 429) {
            Write-Error "refused ($status): $($_.ErrorDetails.Message)"
            exit 1
        }
        if ($attempt -eq $pauses.Count) {
            Write-Error "given up: $($_.Exception.Message)"
            exit 2
        }
        Write-Warning "try again in $($pauses[$attempt]) s: $($_.Exception.Message)"
        Start-Sleep -Seconds $pauses[$attempt]
    }
}
