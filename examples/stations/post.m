% Send a file from MATLAB (R2016b or later) or Octave (7 or later); read the answer; try again where that can help.
%   answer = post('campaign.csv', 'campaigns', 'text/csv')
function answer = post(file, kind, type)
    if nargin < 2, kind = 'campaigns'; end
    if nargin < 3, type = 'application/json'; end
    url = [getenv_or('GYROWATCH_URL', 'http://127.0.0.1:8080') '/v1/' kind];
    if exist('OCTAVE_VERSION', 'builtin'), answer = by_curl(url, file, type); return, end
    text = fileread(file);
    headers = {'Accept-Language', language()};
    token = getenv('GYROWATCH_TOKEN');
    if ~isempty(token), headers = [headers; {'Authorization', ['Bearer ' token]}]; end
    options = weboptions('MediaType', type, 'RequestMethod', 'post', 'Timeout', 120, 'HeaderFields', headers);
    pauses_s = [1 2 5 10 30 60 60];
    for attempt = 0:numel(pauses_s)
        try
            % A char array is sent as it is; a struct would be written anew by jsonencode.
            answer = webwrite(url, text, options);
            return
        catch problem
            % MATLAB:webservices:HTTP422StatusCodeError and the like: the file is at fault.
            code = sscanf(problem.identifier, 'MATLAB:webservices:HTTP%d');
            if ~isempty(code) && code < 500 && ~any(code == [408 425 429]), rethrow(problem); end
            if attempt == numel(pauses_s), rethrow(problem); end
            warning('gyrowatch:again', 'try again in %g s: %s', pauses_s(attempt + 1), problem.message);
            pause(pauses_s(attempt + 1));
        end
    end
end

% Octave's webwrite sends forms alone.
function answer = by_curl(url, file, type)
    token = getenv('GYROWATCH_TOKEN');
    if ~isempty(token), token = ['--header "Authorization: Bearer ' token '" ']; end
    [status, answer] = system(['curl --silent --show-error --fail-with-body --retry 6 --retry-connrefused ' ...
        '--max-time 120 ' token '--header "Accept-Language: ' language() '" --header "Content-Type: ' type '" --data-binary "@' file '" "' url '"']);
    if status ~= 0, error('gyrowatch:notTaken', '%s', answer); end
    answer = jsondecode(answer);
end

% LC_ALL or LANG (zh_CN.UTF-8) choose the language of what is refused.
function found = language()
    found = regexp(getenv_or('LC_ALL', getenv('LANG')), '^[A-Za-z]{2}(?![A-Za-z])', 'match', 'once');
    if isempty(found), found = 'en'; end
end

function value = getenv_or(name, default)
    value = getenv(name);
    if isempty(value), value = default; end
end
